"""Remarks on the numbers of a reproduction of Basu, Oliver and Pentland (1998)."""

REMARKS = (
    "What is tracked was learned from 40 seconds of authored speech, other sentences than those "
    "of the test; its colours from labelled pixels of another clip. Starts are 48 typical shapes "
    "of the training, compared in one batch; the best four are refined. The lips found are "
    "the mean of the four ends by their probability; beside their error stands that of the "
    "highest end alone, whose posterior, iterations and convergence are reported.",
    "Between the shell's rings and behind its inner one, lips are drawn as the person's are at "
    "rest. How these parts follow the shell is taken from the head's face units, three numbers "
    "for each ring that hold for everybody; the filmed speech is made of such units.",
    "From the blob: depth and rotation are given, the visible lips' centroid is brought to the "
    "blob's, then forces move shape and place. An iteration asks for one direction and looks at "
    "three strides along it, of place and shape each, after the first with four multiples of the "
    "step before. It has converged when it gains less than 0.1 of -log posterior. Errors by camera "
    "are those of Nelder-Mead. Frames without a found mouth are left out of errors; `pose.frames` "
    "counts the others. Nelder-Mead by one sample is measured on every fifth frame.",
    "Closures in real clips are those of `abs-engine track` with unknown persons, whose mouths "
    "move in components of face units: no dots of those speakers are known. A spike is a single "
    "frame that is off its neighbours' aperture by 4 mm.",
    "Further training starts from five seconds in which speech's rounded lips are hardly or not "
    "seen: the recording, or authored speech without rounded vowels. Shapes that the full-rank "
    "shell found in a clip of other words, seen from three sides at once, are added with the "
    "covariance of their posterior, in three rounds; the round is kept by which the last fifth of "
    "that clip, which is not learned from, is most probable.",
)
