"""From a depth image to a tower, step by step, as one would in a notebook: python3 build_a_tower.py [FOLDER]"""
import sys
import tempfile

import numpy as np
import stonestack as ss

folder = sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp()

# %% Stones that come with stonestack
catalogue = ss.read_catalogue()
for name in catalogue.names[:2]:
    stone = catalogue[name]
    size = np.ptp(stone.mesh.vertices, axis=0)
    print(f"{name}: {stone.mass:.2f} kg, {np.round(100 * size, 1)} cm")

# %% A simulated depth image, and what is found in it
scene = ss.render(folder + "/scene", seed=1, stones=catalogue.names[:2], catalogue=catalogue)
found = ss.detect(scene.depth, camera_pose=scene.T_W_C, catalogue=catalogue)
truth = dict(scene.stones)
for detection in found.detections:
    T_W_O = scene.T_W_C @ detection.T_C_O
    error = np.linalg.norm(T_W_O[:3, 3] - truth[detection.stone][:3, 3])
    print(f"{detection.stone}: score {detection.score:.2f}, {1000 * error:.1f} mm from the truth")

# %% The same image without a catalogue: each object with its size and its pixels
parts = ss.segment(scene.depth, camera_pose=scene.T_W_C)
for number, part in enumerate(parts.objects, 1):
    pixels = (parts.labels[0] == number).sum()
    print(f"object {number}: {np.round(100 * part.size, 1)} cm, {pixels} pixels, confidence {part.confidence:.2f}")
parts.draw(folder + "/objects.png")

# %% A tower of two, and whether it stands
tower = ss.search(stones=catalogue.names[:2], levels=2, catalogue=catalogue)
for placement in tower.placements:
    print(f"{placement.stone} at {np.round(placement.T_W_O[:3, 3], 3)}, cost {placement.cost:.2f}")
tower.write_scene(folder + "/tower.yaml")
check = ss.check(folder + "/tower.yaml", seconds=2.0, catalogue=catalogue)
print("stands" if check.stands else check.reason, f"with a margin of {check.margin:.2f} g")

# %% A wall of three, in the order in which it is built
wall = ss.search(stones=catalogue.names[:3], wall="2+1", catalogue=catalogue, options={"search.friction": 0.4})
for placement in wall.placements:
    below = [wall.placements[k].stone for k in placement.supports]
    print(f"{placement.stone} in course {placement.course} on {', '.join(below) or 'the table'}")
if wall.wall:
    print(f"{wall.wall.placed} stones, {wall.wall.length:.2f} m long, with a margin of {wall.wall.margin:.2f} g")

# %% A run in the simulated cell: the joints over time
run = ss.run("ur10", seed=1, per_run=1, out=folder + "/run", catalogue=catalogue)
print(f"height {run.height}, ended: {run.ended}, {len(run.time)} samples over {np.ptp(run.time):.0f} s")
assert run.height == 1 and run.q.shape == (len(run.time), 6)
