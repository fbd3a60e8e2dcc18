"""The routes of the API, a file for each family; they only translate, and do nothing themselves."""
