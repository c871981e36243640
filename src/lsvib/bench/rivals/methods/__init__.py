"""One module for each method or package."""
