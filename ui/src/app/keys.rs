//! From keys to commands.

use std::cmp::Reverse;

use egui::{Context, FocusDirection, Key, KeyboardShortcut, Modifiers};

use super::OperatorApp;
use crate::{
    action::Action,
    ui_command::{Scope, UiCommand},
};

impl OperatorApp {
    /// Commands whose keys were pressed. While somebody types, only keys with Ctrl and the palette's count; while a
    /// control has the keyboard, it has the keys that work it.
    pub(super) fn take_keys(&mut self, ctx: &Context) -> Vec<Action> {
        let typing = ctx.text_edit_focused();
        let held = ctx.memory(|memory| memory.focused().is_some());
        // egui has let go of a control for Escape already: that was all it meant.
        let left = std::mem::replace(&mut self.held_keyboard, held) && !held;
        let aims = self.canvas.is_aiming();
        let scope = Scope::Step(self.options.step);
        let dialog = self.options.palette_open || self.options.keys_open;
        let mut commands: Vec<(UiCommand, KeyboardShortcut)> = UiCommand::all()
            .filter(|command| command.scope() == Scope::Global || (command.scope() == scope && !dialog))
            .flat_map(|command| command.keys().iter().map(move |key| (command, *key)))
            .filter(|(command, key)| {
                let with_control = key.modifiers.command;
                (with_control || !typing) && (with_control || !dialog || closes_dialog(*command))
            })
            .filter(|(command, key)| {
                !(held && works_control(*key, aims) || left && *command == UiCommand::SelectNothing)
            })
            .collect();
        // A shortcut with more modifiers is the more special one; the step's own meaning comes before the global one.
        commands.sort_by_key(|(command, key)| {
            (Reverse(modifier_count(key.modifiers)), command.scope() == Scope::Global)
        });
        let mut actions = Vec::new();
        for (command, key) in commands {
            // Hiding masks lasts as long as its key; the canvas peeks at it.
            if command == UiCommand::HideMasks {
                self.options.masks_hidden = !typing && ctx.input(|input| input.key_down(key.logical_key));
                continue;
            }
            // Space held moves the picture; only when it did not, letting go of it plays.
            if command == UiCommand::PlayPause {
                let released = ctx.input(|input| input.key_released(Key::Space) && input.modifiers.is_none());
                if released && !self.canvas.took_space() {
                    actions.push(Action::Run(command));
                }
                continue;
            }
            if ctx.input_mut(|input| input.consume_shortcut(&key)) {
                actions.push(Action::Run(command));
                if matches!(key.logical_key, Key::Tab) {
                    // Tab walks the steps here: it is not to move the keyboard to a control too.
                    ctx.memory_mut(|memory| {
                        if let Some(id) = memory.focused() {
                            memory.surrender_focus(id);
                        }
                        memory.move_focus(FocusDirection::None);
                    });
                }
            }
        }
        actions
    }
}

/// Whether a control with the keyboard, or the cross on the canvas, means something by `key` itself.
fn works_control(key: KeyboardShortcut, aims: bool) -> bool {
    let Modifiers { alt, command, .. } = key.modifiers;
    let arrow = matches!(
        key.logical_key,
        Key::ArrowLeft | Key::ArrowRight | Key::ArrowUp | Key::ArrowDown | Key::Space
    );
    let more = matches!(key.logical_key, Key::Tab | Key::Enter);
    !alt && !command && (arrow || more && !aims)
}

fn closes_dialog(command: UiCommand) -> bool {
    matches!(command, UiCommand::Keys)
}

fn modifier_count(modifiers: Modifiers) -> u32 {
    u32::from(modifiers.alt) + u32::from(modifiers.shift) + u32::from(modifiers.command || modifiers.ctrl)
}
