"""Word gets out: questions, ends, failures and lost devices, by mail, chat or webhook.

Never a way into the bench: nothing that comes back is read.
"""
