#!/usr/bin/env python3
"""Writes the URDF files of this folder from the tables below: python3 data/robots/make_robots.py

Frames are those of Universal Robots' own descriptions (base_link ... tool0, every joint axis is local z); lengths are the
standard DH parameters of UR's data sheet. Collision shapes are our own: capsules (a cylinder with a sphere at either end)
around the housings. Lengths in metres, masses in kilograms, angles in radians.
"""
import math
import pathlib

PI = "3.141592653589793"
HALF_PI = "1.5707963267948966"
LINKS = ["base_link_inertia", "shoulder_link", "upper_arm_link", "forearm_link", "wrist_1_link", "wrist_2_link",
         "wrist_3_link"]
JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]

# Standard DH: d1, a2, a3, d4, d5, d6 (UR's article on DH parameters).
DH = {
    "ur3": (0.1519, -0.24365, -0.21325, 0.11235, 0.08535, 0.0819),
    "ur5": (0.089159, -0.425, -0.39225, 0.10915, 0.09465, 0.0823),
    "ur10": (0.1273, -0.612, -0.5723, 0.163941, 0.1157, 0.0922),
    "ur3e": (0.15185, -0.24355, -0.2132, 0.13105, 0.08535, 0.0921),
    "ur5e": (0.1625, -0.425, -0.3922, 0.1333, 0.0997, 0.0996),
    "ur10e": (0.1807, -0.6127, -0.57155, 0.17415, 0.11985, 0.11655),
    "ur16e": (0.1807, -0.4784, -0.36, 0.17415, 0.11985, 0.11655),
}
# Housings: radii of base, shoulder, upper arm, elbow, forearm, wrists 1 and 2, wrist 3; then how far the upper arm's and
# the forearm's tube lie from the shoulder's centre plane along the shoulder axis.
SHAPE = {
    "ur3": (0.064, 0.056, 0.048, 0.046, 0.042, 0.040, 0.032, 0.1198, 0.0275),
    "ur5": (0.075, 0.070, 0.060, 0.056, 0.050, 0.043, 0.0375, 0.13585, 0.0165),
    "ur10": (0.092, 0.088, 0.075, 0.069, 0.065, 0.055, 0.046, 0.220941, 0.049042),
    "ur3e": (0.064, 0.056, 0.048, 0.046, 0.042, 0.040, 0.032, 0.120, 0.027),
    "ur5e": (0.075, 0.070, 0.060, 0.056, 0.050, 0.045, 0.0375, 0.138, 0.007),
    "ur10e": (0.092, 0.088, 0.075, 0.069, 0.065, 0.055, 0.046, 0.1762, 0.0393),
    "ur16e": (0.092, 0.088, 0.075, 0.069, 0.065, 0.055, 0.046, 0.176, 0.0393),
}
MASS = {
    "ur3": (2.0, 2.0, 3.42, 1.26, 0.8, 0.8, 0.35),
    "ur5": (4.0, 3.7, 8.393, 2.275, 1.219, 1.219, 0.1879),
    "ur10": (4.0, 7.1, 12.7, 4.27, 2.0, 2.0, 0.365),
    "ur3e": (2.0, 1.98, 3.4445, 1.437, 0.871, 0.805, 0.261),
    "ur5e": (4.0, 3.761, 8.058, 2.846, 1.37, 1.3, 0.365),
    "ur10e": (4.0, 7.369, 13.051, 3.989, 2.1, 1.98, 0.615),
    "ur16e": (4.0, 7.369, 10.45, 4.321, 2.18, 2.033, 0.907),
}
# Centres of mass where they are known; the others follow from the capsules.
CENTRE_OF_MASS = {
    "ur10": ((0, 0, 0.03), (0.021, -0.027, 0), (-0.232, 0, 0.158), (-0.3323, 0, 0.068), (0, -0.018, 0.007),
             (0, 0.018, -0.007), (0, 0, -0.026)),
}
# Joint speed in degrees a second, and torque in Nm.
SLOW_BASE = (120, 120, 180, 180, 180, 180)
SPEED = {"ur3": (180, 180, 180, 360, 360, 360), "ur3e": (180, 180, 180, 360, 360, 360), "ur5": (180,) * 6,
         "ur5e": (180,) * 6, "ur10": SLOW_BASE, "ur10e": SLOW_BASE, "ur16e": SLOW_BASE}
TORQUE_3, TORQUE_5, TORQUE_10 = (56, 56, 28, 12, 12, 12), (150, 150, 150, 28, 28, 28), (330, 330, 150, 56, 56, 56)
TORQUE = {"ur3": TORQUE_3, "ur3e": TORQUE_3, "ur5": TORQUE_5, "ur5e": TORQUE_5, "ur10": TORQUE_10, "ur10e": TORQUE_10,
          "ur16e": TORQUE_10}
PAYLOAD = {"ur3": 3, "ur5": 5, "ur10": 10, "ur3e": 3, "ur5e": 5, "ur10e": 10, "ur16e": 16}


def capsules(name):
    """(a, b, radius) a link, in the link's frame."""
    d1, a2, a3, d4, d5, d6 = DH[name]
    base, shoulder, upper, elbow, forearm, wrist, flange, upper_z, forearm_z = SHAPE[name]
    middle_z = 0.5 * (upper_z + forearm_z)
    return [
        [((0, 0, 0), (0, 0, max(0.01, d1 - base)), base)],
        [((0, 0, 0), (0, -0.45 * upper_z, 0), shoulder)],
        [((0, 0, 0.6 * upper_z), (0, 0, upper_z - 0.01), shoulder),
         ((0, 0, upper_z), (a2, 0, upper_z), upper),
         ((a2, 0, middle_z), (a2, 0, upper_z), elbow)],
        [((0, 0, forearm_z), (0, 0, middle_z), elbow),
         ((0, 0, forearm_z), (a3, 0, forearm_z), forearm)],
        [((0, 0, -0.7 * (d4 - forearm_z)), (0, 0, 0), wrist),
         ((0, 0, 0), (0, -0.4 * d5, 0), wrist)],
        [((0, 0, -0.6 * d5), (0, 0, 0), wrist),
         ((0, 0, 0), (0, 0.4 * d6, 0), wrist)],
        [((0, 0, -max(flange + 0.005, 0.55 * d6)), (0, 0, -flange), flange)],
    ]


def rpy_of_axis(axis):
    """Turns z onto one of the directions that the capsules use."""
    return {(1, 0, 0): (0, HALF_PI, 0), (0, 1, 0): (HALF_PI, 0, 0), (0, 0, 1): (0, 0, 0)}[axis]


def numbers(values):
    return " ".join(v if isinstance(v, str) else f"{v + 0.0:.9g}" for v in values)


def collision_xml(link_capsules):
    lines = []

    def shape(centre, rpy, geometry):
        lines.append(f'    <collision>\n      <origin xyz="{numbers(centre)}" rpy="{numbers(rpy)}"/>\n'
                     f'      <geometry><{geometry}/></geometry>\n    </collision>')

    for a, b, radius in link_capsules:
        span = [abs(q - p) for p, q in zip(a, b)]
        length = max(span)
        axis = tuple(1 if s == length else 0 for s in span)
        shape([(p + q) / 2 for p, q in zip(a, b)], rpy_of_axis(axis), f'cylinder radius="{radius}" length="{length:.9g}"')
        for end in (a, b):
            shape(end, (0, 0, 0), f'sphere radius="{radius}"')
    return "\n".join(lines)


def inertia_of(link_capsules, mass, centre):
    """Diagonal inertia about `centre` of the capsules as solid cylinders that share the mass by volume."""
    bars = []
    for a, b, r in link_capsules:
        length = max(abs(q - p) for p, q in zip(a, b)) + 4.0 / 3.0 * r
        axis = max(range(3), key=lambda i: abs(b[i] - a[i]))
        bars.append((math.pi * r * r * length, [(p + q) / 2 for p, q in zip(a, b)], axis, length, r))
    whole = sum(bar[0] for bar in bars)
    if centre is None:
        centre = [sum(bar[0] * bar[1][i] for bar in bars) / whole for i in range(3)]
    inertia = [0.0, 0.0, 0.0]
    for share, middle, axis, length, r in bars:
        m = mass * share / whole
        offset = [middle[i] - centre[i] for i in range(3)]
        for i in range(3):
            own = m * r * r / 2 if i == axis else m * (3 * r * r + length * length) / 12
            inertia[i] += own + m * sum(offset[j] ** 2 for j in range(3) if j != i)
    return centre, inertia


def link_xml(name, index):
    shapes = capsules(name)[index]
    mass = MASS[name][index]
    centre, inertia = inertia_of(shapes, mass, CENTRE_OF_MASS.get(name, (None,) * 7)[index])
    return (f'  <link name="{LINKS[index]}">\n    <inertial>\n      <origin xyz="{numbers(centre)}" rpy="0 0 0"/>\n'
            f'      <mass value="{mass}"/>\n      <inertia ixx="{inertia[0]:.6g}" ixy="0" ixz="0" iyy="{inertia[1]:.6g}" '
            f'iyz="0" izz="{inertia[2]:.6g}"/>\n    </inertial>\n{collision_xml(shapes)}\n  </link>')


def joint_xml(name, index):
    d1, a2, a3, d4, d5, d6 = DH[name]
    xyz, rpy = [((0, 0, d1), (0, 0, 0)), ((0, 0, 0), (HALF_PI, 0, 0)), ((a2, 0, 0), (0, 0, 0)), ((a3, 0, d4), (0, 0, 0)),
                ((0, -d5, 0), (HALF_PI, 0, 0)), ((0, d6, 0), (HALF_PI, PI, PI))][index]
    bound = math.pi if JOINTS[index] == "elbow_joint" else 2 * math.pi
    speed = math.radians(SPEED[name][index])
    return (f'  <joint name="{JOINTS[index]}" type="revolute">\n    <parent link="{LINKS[index]}"/>\n'
            f'    <child link="{LINKS[index + 1]}"/>\n    <origin xyz="{numbers(xyz)}" rpy="{numbers(rpy)}"/>\n'
            f'    <axis xyz="0 0 1"/>\n    <limit lower="{-bound!r}" upper="{bound!r}" effort="{TORQUE[name][index]}" '
            f'velocity="{speed!r}"/>\n  </joint>')


def fixed_xml(name, parent, child, rpy):
    return (f'  <joint name="{name}" type="fixed">\n    <parent link="{parent}"/>\n    <child link="{child}"/>\n'
            f'    <origin xyz="0 0 0" rpy="{numbers(rpy)}"/>\n  </joint>')


def robot_xml(name):
    # The controller's base frame is turned by half a turn against base_link.
    parts = ['<?xml version="1.0"?>', f"<!-- Written by make_robots.py. -->", f'<robot name="{name}">',
             '  <link name="base_link"/>', fixed_xml("base_link-base_link_inertia", "base_link", LINKS[0], (0, 0, PI))]
    for i in range(7):
        parts.append(link_xml(name, i))
        if i < 6:
            parts.append(joint_xml(name, i))
    parts += ['  <link name="tool0"/>', fixed_xml("wrist_3-tool0", LINKS[6], "tool0", (0, 0, 0)), "</robot>"]
    return "\n".join(parts) + "\n"


if __name__ == "__main__":
    folder = pathlib.Path(__file__).parent
    for robot in DH:
        (folder / f"{robot}.urdf").write_text(robot_xml(robot))
        (folder / f"{robot}.yaml").write_text(
            f"# What a URDF has no place for. Acceleration is not public: ours.\npayload: {PAYLOAD[robot]}  # kg\n"
            "acceleration: 1.4  # rad/s^2, every joint\n")
