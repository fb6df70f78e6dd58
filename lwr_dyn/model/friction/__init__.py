"""Joint friction: models per direction, their smooth form, and whether they can feed energy into the arm."""
