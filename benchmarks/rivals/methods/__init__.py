"""One module for each method or package, loaded when it is used."""
