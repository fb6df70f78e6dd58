"""`lwr-dyn krl`: one file a subcommand, one group."""
