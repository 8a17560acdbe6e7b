"""Pages for a browser: templates and scripts, and the server of the live one."""
