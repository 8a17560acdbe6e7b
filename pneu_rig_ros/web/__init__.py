"""Pages for a browser: templates, scripts, and the server of the live page."""
