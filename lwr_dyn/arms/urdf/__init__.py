"""Arm to URDF and SRDF with the source of every number, and foreign URDFs back to Arm.

writer        urdf_text: the URDF, and the source of each number in it
provenance    provenance_text: the sidecar that lists these sources
model_files   model_files: all files of an arm, with the rotors' SRDF
geometry      primitives: default shapes of an arm without a drawing
reader        read_urdf: a foreign URDF as an Arm
parse, foreign_xml, tree, carried, elements, xml_text    parts of reader and writer
"""
