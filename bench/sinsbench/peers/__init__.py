"""Published packages as subjects: each fed by its documented convention, in a process of its own environment."""
