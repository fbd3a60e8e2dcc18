"""The language, its checks, the tree it becomes, the journal, the runner and the command line."""
