"""Tables whose conventions nobody states: every reading of them, ranked by what a body, an arm and a paper allow."""
