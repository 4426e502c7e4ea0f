"""Planted faults that check_prose.py must find, and good lines that it must accept."""
import sys

from check_prose import bad_start, bad_test_name, bad_words

BAD_STARTS = ["That which holds", "m between the pads", "N at finger A", "s, between checks", "rad", "The same for the table",
              "kg at the tips", "J at the end"]
GOOD_STARTS = ["Distance between the pads [m]", "[m]", "Maps a stone to the world", "s1 of the path", "mass of the stone [kg]"]
BAD_LINES = [
    "/// Opens the hand.", "const HandPose pose;", "double hand_reach = 0.1;", "// as the program believes", "double belief = 0.0;",
    "// 3 N; ours", "// where the wrist is in doubt", "JointPath mended(const JointPath& path);", "// the next way point",
    "/// A pose of rest.", "// keeps its pose to the letter", "// the look is free", "/// How a stone is turned over.",
    "double least_margin = 0.1;", "constexpr double kMostTurn = 0.1;", "double largest_opening = 0.155;", "if (no_room) return;",
]
GOOD_LINES = [
    "/// Opens the gripper.", "HandEyeResult calibrate_hand_eye();", "// solved by hand", "return handle_of(handler);", "nonnegative_least_squares(a);",
    "Random random = Random::stream(seed, \"steadied\");", "{\"doubt\", e.uncertainty},", "/// - {a: hand, b: table, m: 0.004}",
    "// at least one stone, at most three", "// the largest of all", "int most_likely(int k);", "recommended(x);", "// waypoints",
]

BAD_TESTS = ["TEST(World, WhatFallsIsGone) {", "TEST_F(Site, NobodyThereIsNamed) {"]
GOOD_TESTS = ["TEST(World, FallenStonesAreGone) {", "TEST(Whatever, Whatnot) {"]

wrong = [f"not found: {text}" for text in BAD_STARTS if not bad_start(text)]
wrong += [f"found in: {text}" for text in GOOD_STARTS if bad_start(text)]
wrong += [f"not found: {line}" for line in BAD_LINES if not bad_words(line)]
wrong += [f"found in: {line}: {bad_words(line)}" for line in GOOD_LINES if bad_words(line)]
wrong += [f"not found: {line}" for line in BAD_TESTS if not bad_test_name(line)]
wrong += [f"found in: {line}" for line in GOOD_TESTS if bad_test_name(line)]
if wrong:
    sys.exit("\n".join(wrong))
print(f"{len(BAD_STARTS) + len(BAD_LINES) + len(BAD_TESTS)} faults found, "
      f"{len(GOOD_STARTS) + len(GOOD_LINES) + len(GOOD_TESTS)} good lines accepted")
