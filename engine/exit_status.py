"""The exit statuses of the commands."""

SUCCEEDED = 0
FAILED = 1
PROBLEMS = 2
NOT_REACHED = 4
FAULT = 70
CTRL_C = 130
