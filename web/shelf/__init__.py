"""The folder of protocols: files with revisions, and what checker and views say of them."""
