"""Faults in URDF files: each link, joint and shape as written, with its place, the reason and what to write instead.

document             A URDF as written: links, joints and their places, what a joint moves and how links hang
                     together; its findings
drive_rules          Rules of drives: friction, rotors, travel, speeds that look like rpm, efforts against the weight
                     and the others
elements             Links and joints of a URDF, each number as written; what cannot be read is None and has a finding
                     of its own
hulls                Convex hulls of bodies, and the meshes that they are made of
inertia_shape_rules  Rules of mass, centre of mass and inertia against the shapes of the link, and masses as far as
                     they can be believed
inertial_rules       Rules of inertials that need no shape: missing, zero, negative, impossible, a stand-in, in grams
                     or millimetres
joint_rules          Rules of joints: the tree that they make, limits, axes, origins, angles in degrees or parts of
                     quaternions
judgement            Each link's inertial held against the convex hull of its own shapes, with the slip that explains
                     what is odd
lint                 A URDF judged by every rule: the findings with their severity, without those that the user
                     ignores
mirror_rules         Rules of two links of one shape: left and right, or the same part again, turned by quarters or
                     mirrored
reader_rules         What this package's own reader of arms refuses in a file: the reader itself is asked, so that the
                     two are one
reports              What `lwr-dyn lint` makes of URDFs: the files of folders, findings grouped by cause, and their
                     outputs
schema_rules         Rules of the format: the outermost element, names, tags, attributes, numbers
shape_rules          Rules of the shapes: files that are not there or cannot be read, scales, sizes, units; bodies
                     that do not meet
undoings             Faults undone: each odd tensor or centre is tried as if one named slip had been made, and put
                     right
xml_tree             XML text as elements that know their place: by expat, without namespaces, as urdfdom and Drake
                     read a URDF

    from lwr_dyn.checks.urdf.lint import lint_file
    for finding in lint_file("arm.urdf").findings: print(finding.place, finding.level, finding.message)
"""
