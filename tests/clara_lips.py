"""Clara's lips, trained once for the tests that look at what was learned."""

from __future__ import annotations

from abs_engine.face.shape.lip_shell import cut_lip_shell
from abs_engine.io.assets import load_speaker
from abs_engine.learn.training import train
from abs_engine.papers.basu1998.motion import authored_motion, observed_motion

SPEAKER = load_speaker()
SHELL = cut_lip_shell(SPEAKER)
MOTION = authored_motion(SPEAKER, "clara")
SEEN = observed_motion(SPEAKER, MOTION, noise=0.1)
TRAINED = train(SEEN, SPEAKER, "clara", shell=SHELL)
