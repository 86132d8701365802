"""Its presence puts this directory on the import path, for the helpers all tests share."""
