//! A window that opens anew when its graphics device is lost, with all that was in it.

use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::rc::Rc;
use std::time::{Duration, Instant};

use eframe::UserEvent;
use winit::event_loop::EventLoop;
use winit::platform::run_on_demand::EventLoopExtRunOnDemand as _;

use super::guard::Guard;
use super::{GuiError, native_options, no_display, why_no_window};
use crate::gui::keeping::Layout;
use crate::render::panic_message;

/// What is in a window, and goes on in another one when the graphics device of the first is lost.
pub(in crate::gui) trait Survivor: eframe::App {
    /// Has the driver say whether the graphics device is still there.
    fn ask_driver(&self);

    /// Why the graphics device is of no use any more, as far as the driver has said; `None` as long as it is there.
    fn loss(&self) -> Option<String>;

    /// Goes on in a new window, after the device of the one before was lost for the reason `loss`.
    fn move_to(&mut self, creation: &eframe::CreationContext<'_>, loss: &str);

    /// There will be no other window: puts work in safety.
    fn give_up(&mut self);
}

/// A device that is lost sooner after the last loss was never of any use.
const USEFUL: Duration = Duration::from_secs(5);
/// So many such devices in a row are enough.
const MOST_USELESS: usize = 3;
/// How long a driver may take to say that its device is lost, once drawing has failed.
const LATE: Duration = Duration::from_secs(1);

/// Opens a window that looks like `layout`, with what `create` makes in it, and opens it anew whenever its graphics device is lost.
pub(in crate::gui) fn open<A: Survivor + 'static>(
    layout: &Layout,
    create: impl FnOnce(&eframe::CreationContext<'_>) -> A,
) -> Result<(), GuiError> {
    // One for all windows: no process may have two.
    let events = catch_unwind(|| EventLoop::<UserEvent>::with_user_event().build());
    let mut events = events
        .map_err(|payload| GuiError::Panicked {
            reason: panic_message(payload.as_ref()),
        })?
        .map_err(|error| no_display(&error))?;
    let mut create = Some(create);
    let mut before: Option<Saved<A>> = None;
    let mut useless = 0;
    loop {
        let opened_at = Instant::now();
        let place = Place::default();
        let mut native = native_options(layout);
        if let Some(Saved { window, .. }) = &before {
            native.viewport = placed_as(native.viewport, window);
        }
        // Where no window opens, what was saved is still here.
        place.waiting.replace(before.take());
        let fault = show(&mut events, native, create.take(), &place)?;
        let (saved, waiting) = (place.saved.take(), place.waiting.take());
        if let Some(mut lost) = waiting {
            // The first window of all has nothing that waits.
            lost.app.give_up();
            let reason = fault.unwrap_or_else(|| "no other window opens".to_owned());
            return Err(GuiError::DeviceLost { reason });
        }
        let Some(mut saved) = saved else {
            return match fault {
                Some(reason) => Err(GuiError::Panicked { reason }),
                None if place.is_filled.get() => Ok(()),
                None => Err(why_no_window()),
            };
        };
        let Some(reason) = saved.loss.clone() else {
            saved.app.give_up();
            let reason = fault.unwrap_or_default();
            return Err(GuiError::Fault { reason });
        };
        useless = if opened_at.elapsed() < USEFUL {
            useless + 1
        } else {
            0
        };
        if useless >= MOST_USELESS {
            saved.app.give_up();
            return Err(GuiError::DeviceLost { reason });
        }
        before = Some(saved);
    }
}

/// What is handed from one window to the next.
struct Place<A> {
    /// What is to go on in the window, until that is there.
    waiting: Rc<RefCell<Option<Saved<A>>>>,
    /// What was in the window when it went.
    saved: Rc<RefCell<Option<Saved<A>>>>,
    /// Whether there was a window with something in it.
    is_filled: Rc<Cell<bool>>,
    /// Whether it ended by a fault.
    has_failed: Rc<Cell<bool>>,
}

impl<A> Default for Place<A> {
    fn default() -> Self {
        Self {
            waiting: Rc::default(),
            saved: Rc::default(),
            is_filled: Rc::default(),
            has_failed: Rc::default(),
        }
    }
}

/// Shows a window until it closes, with what waits in `place`, or with what `create` makes. Returns the fault that it ended by.
fn show<A: Survivor + 'static>(
    events: &mut EventLoop<UserEvent>,
    native: eframe::NativeOptions,
    create: Option<impl FnOnce(&eframe::CreationContext<'_>) -> A>,
    place: &Place<A>,
) -> Result<Option<String>, GuiError> {
    let waiting = Rc::clone(&place.waiting);
    let is_filled = Rc::clone(&place.is_filled);
    let (saved, has_failed) = (Rc::clone(&place.saved), Rc::clone(&place.has_failed));
    let fill = move |creation: &eframe::CreationContext<'_>| {
        let app = match (waiting.take(), create) {
            (Some(mut before), _) => {
                let memory = before.window.memory(Clone::clone);
                creation.egui_ctx.memory_mut(|new| *new = memory);
                let loss = before.loss.unwrap_or_default();
                before.app.move_to(creation, &loss);
                before.app
            }
            (None, Some(create)) => create(creation),
            (None, None) => return Err("there is nothing to show".into()),
        };
        is_filled.set(true);
        let hosted = Hosted {
            app: Some(app),
            window: creation.egui_ctx.clone(),
            saved,
            has_failed,
        };
        Ok(Box::new(hosted) as Box<dyn eframe::App>)
    };
    let window = eframe::create_native("RayMini", native, Box::new(fill), events);
    let mut guard = Guard::new(window, Rc::clone(&place.has_failed));
    let run = AssertUnwindSafe(|| events.run_app_on_demand(&mut guard));
    match catch_unwind(run) {
        Ok(Ok(())) => Ok(guard.into_fault()),
        Ok(Err(error)) => Err(no_display(&error)),
        Err(payload) => Err(GuiError::Panicked {
            reason: panic_message(payload.as_ref()),
        }),
    }
}

/// A window where the lost one was, as large as that.
fn placed_as(builder: egui::ViewportBuilder, lost: &egui::Context) -> egui::ViewportBuilder {
    let (inner, outer, is_maximized) = lost.input(|input| {
        let viewport = input.viewport();
        (viewport.inner_rect, viewport.outer_rect, viewport.maximized)
    });
    let mut builder = builder.with_maximized(is_maximized.unwrap_or(false));
    if let Some(inner) = inner {
        builder = builder.with_inner_size(inner.size());
    }
    if let Some(outer) = outer {
        builder = builder.with_position(outer.min);
    }
    builder
}

/// What outlives its window.
struct Saved<A> {
    app: A,
    /// The window that was.
    window: egui::Context,
    /// Why its device was lost; `None` where it was not, and the program has a fault.
    loss: Option<String>,
}

/// What is in a window, which closes when its device is lost.
struct Hosted<A: Survivor> {
    /// `None` once it is saved.
    app: Option<A>,
    window: egui::Context,
    saved: Rc<RefCell<Option<Saved<A>>>>,
    has_failed: Rc<Cell<bool>>,
}

impl<A: Survivor> Hosted<A> {
    fn app(&mut self) -> &mut A {
        self.app.as_mut().expect("it is saved last")
    }

    fn loss(&self) -> Option<String> {
        self.app.as_ref().and_then(Survivor::loss)
    }

    /// The loss that drawing has failed by, which the driver may be late to tell.
    fn late_loss(&self) -> Option<String> {
        let failed_at = Instant::now();
        while self.loss().is_none() && failed_at.elapsed() < LATE {
            self.app.iter().for_each(Survivor::ask_driver);
            std::thread::sleep(Duration::from_millis(5));
        }
        self.loss()
    }
}

impl<A: Survivor> eframe::App for Hosted<A> {
    fn raw_input_hook(&mut self, ctx: &egui::Context, raw_input: &mut egui::RawInput) {
        if self.loss().is_none() {
            self.app().raw_input_hook(ctx, raw_input);
        }
    }

    fn logic(&mut self, ctx: &egui::Context, frame: &mut eframe::Frame) {
        self.app().ask_driver();
        if self.loss().is_none() {
            self.app().logic(ctx, frame);
        }
    }

    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        // Nothing is drawn with a device that is not there: to the library that draws, it would be a fault to give up at.
        if self.loss().is_some() {
            ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close);
        } else {
            self.app().ui(ui, frame);
        }
    }

    fn on_exit(&mut self) {
        if self.loss().is_none() {
            self.app().on_exit();
        }
    }
}

impl<A: Survivor> Drop for Hosted<A> {
    fn drop(&mut self) {
        let has_failed = self.has_failed.get();
        let loss = if has_failed {
            self.late_loss()
        } else {
            self.loss()
        };
        if (has_failed || loss.is_some())
            && let Some(app) = self.app.take()
        {
            let window = self.window.clone();
            self.saved.replace(Some(Saved { app, window, loss }));
        }
    }
}
