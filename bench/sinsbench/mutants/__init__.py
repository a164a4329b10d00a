"""The suite validated: defects planted in every coefficient and term of the subjects, which the score must see."""
