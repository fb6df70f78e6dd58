"""A report as one HTML file: `content` and `curves` are what it shows, `page` writes it."""
