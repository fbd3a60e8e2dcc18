"""What a person sees of a run in a browser: for now its report, one page that needs no server."""
