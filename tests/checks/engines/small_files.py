"""A two-joint URDF with everything that an engine may lose."""

INERTIA = '<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.01"/>'
ROTOR = """
  <transmission name="t1"><type>transmission_interface/SimpleTransmission</type><joint name="j1"/>
    <actuator name="m1"><drake:gear_ratio value="100"/><drake:rotor_inertia value="1e-5"/></actuator></transmission>"""
TWO = f"""<?xml version="1.0"?>
<robot name="two" xmlns:drake="https://drake.mit.edu/">
  <link name="base"/>
  <joint name="j1" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.3"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="50" velocity="3"/>
    <dynamics damping="0.7" friction="0.4"/></joint>
  <link name="upper"><inertial><origin xyz="0.1 0 0.2" rpy="0.3 0.5 0"/><mass value="2"/>{INERTIA}</inertial></link>
  <joint name="j2" type="continuous"><parent link="upper"/><child link="lower"/><origin xyz="0 0 0.4"/>
    <axis xyz="1 0 0"/><limit effort="20" velocity="4"/></joint>
  <link name="lower"><inertial><origin xyz="0 0 0.1"/><mass value="1"/>{INERTIA}</inertial></link>
  <joint name="fixed" type="fixed"><parent link="lower"/><child link="tool"/><origin xyz="0 0 0.2"/></joint>
  <link name="tool"><visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual>
    <collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>{ROTOR}
</robot>
"""
