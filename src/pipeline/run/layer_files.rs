//! Every frame's layers as pictures, without loss.

use crate::{
    clip::FrameIndex,
    engine::Layers,
    export::{ClipFolder, ExportError, write_rgb, write_rgba},
};

/// Writes one frame's layers: `layers/{background,robot,object,front,composite}/{frame:06}.png`. Where the object is
/// absent it has no picture.
pub(super) fn write(folder: &ClipFolder, index: FrameIndex, layers: &Layers) -> Result<(), ExportError> {
    write_rgb(&folder.layer_file("background", index)?, &layers.background)?;
    write_rgba(&folder.layer_file("robot", index)?, &layers.robot)?;
    if let Some(object) = &layers.object {
        write_rgba(&folder.layer_file("object", index)?, object)?;
    }
    write_rgba(&folder.layer_file("front", index)?, &layers.front)?;
    write_rgb(&folder.layer_file("composite", index)?, &layers.composite)
}
