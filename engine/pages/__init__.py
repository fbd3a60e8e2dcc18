"""Pages of the manual for problems that are found while a file is read; checks have their own."""
