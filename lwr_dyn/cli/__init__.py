"""The command `lwr-dyn`, one file per subcommand."""
