//! M_inpaint = M_hand ∩ ¬M_obj and the temporal background plate.
