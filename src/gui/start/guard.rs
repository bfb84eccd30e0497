//! Faults while a window draws.
//!
//! wgpu panics in the middle of a frame when its device is gone. Unwinding through winit would leave it unable to open another window, so
//! the panic is caught between the two.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::rc::Rc;

use eframe::{EframeWinitApplication, UserEvent};
use winit::application::ApplicationHandler;
use winit::event::{DeviceEvent, DeviceId, StartCause, WindowEvent};
use winit::event_loop::ActiveEventLoop;
use winit::window::WindowId;

use crate::render::panic_message;

/// A window whose faults end it.
pub(super) struct Guard<'a> {
    /// `None` once it has ended by a fault.
    window: Option<EframeWinitApplication<'a>>,
    /// Set before what is in the window is dropped because of a fault.
    has_failed: Rc<Cell<bool>>,
    fault: Option<String>,
}

impl<'a> Guard<'a> {
    /// A guard of `window`; `has_failed` is set when that ends by a fault.
    pub fn new(window: EframeWinitApplication<'a>, has_failed: Rc<Cell<bool>>) -> Self {
        Self {
            window: Some(window),
            has_failed,
            fault: None,
        }
    }

    /// The fault that the window ended by.
    pub fn into_fault(self) -> Option<String> {
        self.fault
    }

    /// Has the window take in an event.
    fn pass_on(
        &mut self,
        event_loop: &ActiveEventLoop,
        event: impl FnOnce(&mut EframeWinitApplication<'a>),
    ) {
        let Some(window) = &mut self.window else {
            return event_loop.exit();
        };
        if let Err(payload) = catch_unwind(AssertUnwindSafe(|| event(window))) {
            self.fault = Some(panic_message(payload.as_ref()));
            self.has_failed.set(true);
            let window = self.window.take();
            // What belongs to a device that is gone may not go without complaint.
            let _ = catch_unwind(AssertUnwindSafe(|| drop(window)));
            event_loop.exit();
        }
    }
}

impl ApplicationHandler<UserEvent> for Guard<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        self.pass_on(event_loop, |window| window.resumed(event_loop));
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, id: WindowId, event: WindowEvent) {
        self.pass_on(event_loop, |window| {
            window.window_event(event_loop, id, event);
        });
    }

    fn new_events(&mut self, event_loop: &ActiveEventLoop, cause: StartCause) {
        self.pass_on(event_loop, |window| window.new_events(event_loop, cause));
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, event: UserEvent) {
        self.pass_on(event_loop, |window| window.user_event(event_loop, event));
    }

    fn device_event(&mut self, event_loop: &ActiveEventLoop, id: DeviceId, event: DeviceEvent) {
        self.pass_on(event_loop, |window| {
            window.device_event(event_loop, id, event);
        });
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        self.pass_on(event_loop, |window| window.about_to_wait(event_loop));
    }

    fn suspended(&mut self, event_loop: &ActiveEventLoop) {
        self.pass_on(event_loop, |window| window.suspended(event_loop));
    }

    fn exiting(&mut self, event_loop: &ActiveEventLoop) {
        self.pass_on(event_loop, |window| window.exiting(event_loop));
    }

    fn memory_warning(&mut self, event_loop: &ActiveEventLoop) {
        self.pass_on(event_loop, |window| window.memory_warning(event_loop));
    }
}
