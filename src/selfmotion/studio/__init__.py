"""The studio: a page on which arm, path and motion are seen and moved, and the server behind it."""
