"""The data room: one TOML file per paper, the strict reader, errata and readings."""
