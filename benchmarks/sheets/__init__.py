"""Data sheets by plain numbers and motions of their own, by which tests judge what is said of a sheet."""
