"""References that people bring (files, steps, chirps), and what a loop made of them."""
