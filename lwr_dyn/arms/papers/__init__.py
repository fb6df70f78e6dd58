"""Data files: one TOML file per paper or data sheet, read strictly, corrected by errata, turned into an Arm.

assembly  Paper -> Arm: columns in SI become DH rows, bodies, rotors, friction and limits; each quantity keeps its
          cells
catalog   Data files: the robots that come with the package, by name, and the template of a user's own arm
columns   Columns of a data file: one row per joint, finite numbers, units of the right quantity, a source
reader    The strict reader: TOML text -> `Paper`. An unknown, missing, misspelt or non-finite entry raises, with its
          place
schema    The schema of a data file: tables, columns, shapes, the records that the reader returns, and units
sets      Published sets of one robot's numbers in one data file: `[[set]]`, whose tables take the place of those of
          the file
solids    The solids of a drawn arm, and the bodies estimated from them where a source gives only a total mass
"""
