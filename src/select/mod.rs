//! Which object: contact motion, operator, later a VLM.
