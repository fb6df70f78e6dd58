"""A report as one HTML file: `content` is what it shows, `page` writes it."""
