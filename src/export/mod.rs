//! Video, record, masks, crops.
