//! What background jobs have to say.

use std::time::Instant;

use super::App;
use crate::gui::costs::CostState;
use crate::gui::dialogs::Dialog;
use crate::gui::dialogs::path_field::Listing;
use crate::gui::event::Event;
use crate::gui::jobs::{Lane, News};
use crate::gui::picture::{Outcome, Picture};
use crate::gui::time_estimate::TimeState;
use crate::io::holds_layers;

impl App {
    /// Puts on the screen what has come of pictures. Only once the edits of a frame are followed: pieces of a picture that one of them replaces would
    /// go to the driver in vain, and take more of the frame than the first look at the new one.
    pub(super) fn show_tiles(&mut self, ctx: &egui::Context) {
        let is_shown = |app: &Self| app.shown_picture().is_some_and(Picture::is_shown);
        let was_shown = is_shown(self);
        let shown = self.shown_number();
        if let Some(picture) = &mut self.picture {
            picture.show_tiles(ctx);
        }
        if let Some(picture) = shown.and_then(|number| self.renders.picture_mut(number)) {
            picture.show_tiles(ctx);
        }
        if let Some(comparison) = &mut self.comparison {
            comparison.show_tiles(ctx);
        }
        if is_shown(self) != was_shown {
            // What the bars offer was laid out before.
            ctx.request_repaint();
        }
    }

    /// Takes in what background jobs have to say, for a few milliseconds at most.
    pub(super) fn take_news(&mut self, ctx: &egui::Context) {
        const BUDGET_SECONDS: f64 = 0.002;
        let started = Instant::now();
        while let Some(news) = self.jobs.next_event() {
            match news {
                News::Event(event) => self.take_event(ctx, event),
                News::Panicked(lane, message) => self.job_failed(lane, &message),
            }
            if started.elapsed().as_secs_f64() > BUDGET_SECONDS {
                ctx.request_repaint();
                return;
            }
        }
        if !self.jobs.is_busy(Lane::Load) {
            self.loading = None;
        }
    }

    fn take_event(&mut self, ctx: &egui::Context, event: Event) {
        match event {
            Event::SceneLoaded { paths, result } => {
                self.scene_loaded(&paths, result.map(|opened| *opened));
            }
            Event::FilesMissing(missing) => self.files_missing(missing),
            Event::Located(result) => self.located(result),
            Event::SoughtRead { file, result } => self.sought_read(file, result),
            Event::ModelsLoaded {
                paths,
                replaces,
                result,
            } => self.models_loaded(paths, replaces, result),
            Event::RenderDropped(path) => self.dropped_render(path),
            Event::ImageLoaded { path, result } => self.image_loaded(&path, result),
            Event::TextureLoaded {
                path,
                material,
                texture,
                result,
            } => self.texture_loaded(&path, &material, texture, result),
            Event::Placed(placed) => self.placed(*placed),
            Event::Prepared(result) => self.prepared(result.map(|prepared| *prepared)),
            Event::Coarse(texels) => {
                if let Some(picture) = &mut self.picture {
                    picture.take_coarse(texels);
                }
            }
            Event::Tile(tile) => {
                if let Some(picture) = &mut self.picture {
                    picture.take_tile(tile);
                }
            }
            Event::Encoded { number, encoded } => {
                if let Some(picture) = self.picture_of_mut(number) {
                    picture.take_encoded(encoded);
                }
            }
            Event::Compared(result) => {
                if let Some(comparison) = &mut self.comparison {
                    comparison.set_distance(result);
                }
            }
            Event::CompareEncoded(side, encoded) => {
                if let Some(comparison) = &mut self.comparison {
                    comparison.take(side, encoded);
                }
            }
            Event::ComparisonRead { path, result } => self.comparison_read(&path, result),
            Event::HistogramMade(histogram) => self.brightness.histogram = Some(histogram),
            Event::Thumbnail { picture, image } => {
                let present = self.picture.as_ref();
                self.renders.set_thumbnail(ctx, present, picture, image);
            }
            Event::BallRendered { material, image } => self.balls.put(ctx, material, image),
            Event::ContributionFound {
                contributor,
                contribution,
            } => self.contributions.put(ctx, contributor, contribution),
            Event::Traced { wanted, result } => self.traced(*wanted, result),
            Event::Rendered { hash, stats } => self.rendered(hash, stats),
            Event::RenderFailed {
                text,
                is_short_of_memory,
            } => self.render_failed(&text, is_short_of_memory),
            Event::SceneSaved { file, path, result } => self.scene_saved(ctx, file, path, result),
            Event::PictureSaved {
                path,
                picture,
                is_whole,
                is_final,
                result,
            } => {
                if matches!(result, Ok(Some(()))) && is_final {
                    self.picture_is_saved(picture, holds_layers(&path));
                }
                self.picture_saved(&path, is_whole, result);
            }
            Event::PathsChosen(answer) => self.paths_chosen(answer),
            Event::ReportGrew(findings) => self.report.set_findings(findings),
            Event::Reported(result) => self.reported(&result),
            Event::CostsMeasured { scene, result } => self.costs_measured(scene, result),
            Event::TimeEstimated { subject, result } => self.time_estimated(subject, result),
            Event::KeepingBegun { recent, begun } => self.keeping_begun(recent, begun),
            Event::WorkKept(result) => self.work_kept(result),
            Event::Restored { lost, result } => self.restored(lost, result),
            Event::RenderGoesOn {
                share_done,
                seconds,
            } => self.render_goes_on(share_done, seconds),
            Event::RenderLost(reason) => self.render_lost(&reason),
            Event::RenderNotKept(reason) => self.render_not_kept(&reason),
            Event::RecentChanged(recent) => self.keeping.recent = recent,
            Event::FilesChanged(paths) => self.files_changed(paths),
            Event::FilesGone(paths) => self.files_gone(&paths),
            Event::Reloaded { stale, result } => self.reloaded(&stale, result),
            Event::FolderNotShown(reason) => self.report.folder_not_shown(&reason),
            Event::Listed(listing) => self.listed(listing),
        }
    }

    /// The folder of a path that is typed has been read.
    fn listed(&mut self, listing: Listing) {
        if let Some(Dialog::Path(field)) = &mut self.dialog {
            field.set_listing(listing);
        }
    }

    /// A job ended by a fault of the program.
    fn job_failed(&mut self, lane: Lane, message: &str) {
        match lane {
            Lane::Load => self.loading = None,
            Lane::Render => self.end_picture(Outcome::Failed),
            Lane::Encode => self.await_look_of(None),
            Lane::SaveScene => {
                self.scene_saves.pop_front();
                self.after_saving = None;
            }
            Lane::SavePicture => self.picture_save_failed(),
            Lane::Dialog => self.after_saving = None,
            Lane::Keep => self.keep_failed(),
            Lane::Report => self.report.fail_by_fault(),
            Lane::Costs => self.costs = CostState::Unknown,
            Lane::Time => self.time = TimeState::Unknown,
            Lane::Balls => self.balls.give_up(),
            Lane::Contributions => self.contributions.give_up(),
            _ => {}
        }
        let text =
            format!("This is a fault of the program, and your scene is still here: {message}");
        self.messages.error("Something went wrong", text);
    }
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use crate::gui::app::testing;

    #[test]
    fn what_comes_of_a_picture_waits_for_the_edits_of_the_frame() {
        let mut window = testing::window(None);
        let ctx = window.ctx.clone();
        let app = window.state_mut();
        app.ask_for_render();
        let deadline = Instant::now() + Duration::from_mins(1);
        while app.picture().is_none_or(|p| p.first_tile.is_none()) {
            assert!(Instant::now() < deadline, "no tile comes");
            app.take_news(&ctx);
            std::thread::sleep(Duration::from_millis(2));
        }
        assert!(!app.picture().unwrap().is_shown());
        window.step();
        assert!(window.state().picture().unwrap().is_shown());
    }
}
