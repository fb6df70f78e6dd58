"""Types of KRL, and the names that every controller has without a declaration."""
