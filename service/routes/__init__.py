"""Routes of the HTTP service: each parses, calls the engine and answers."""
