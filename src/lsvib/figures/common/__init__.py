"""Parts of datasets that several figures share."""
