"""The main job: the papers' own cases from truth to verdicts, in one go."""
