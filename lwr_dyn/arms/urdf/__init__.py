"""Arm to URDF and SRDF with the source of every number, and foreign URDFs back to Arm.

writer       urdf_text: the URDF, and the source of each number in it
model_files  model_files: all files of an arm; provenance_text: the sidecar of sources; the rotors' SRDF
geometry     primitives: default shapes of an arm without a drawing
elements     elements and numbers of the files
reader       read_urdf: a foreign URDF as an Arm
parse        XML of foreign files, checked
tree         its links, and which of its chains is the arm
"""
