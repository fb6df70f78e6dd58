"""Names of C and JavaScript from names of arms and files."""

import re


def identifier(name: str) -> str:
    """A name as an identifier: letters, digits and single underscores, a letter first (C++ reserves the others).

    >>> identifier("KR 30-HA"), identifier("7dof arm"), identifier("ö")
    ('KR_30_HA', 'arm_7dof_arm', 'arm')
    """
    made = re.sub(r"_+", "_", re.sub(r"[^A-Za-z0-9]", "_", name)).strip("_")
    return made if made[:1].isalpha() else f"arm_{made}".rstrip("_")
