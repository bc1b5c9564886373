//! The loop over steps: parallel stages, with the serial work between them.

use std::cell::UnsafeCell;

use granum_simd::dispatch;

use crate::bond::{BondedStage, TurningStage, bond_stage};
use crate::contact_sums::ContactSums;
use crate::integrator::Integrator;
use crate::kernel::{self, ClumpStage, GrainStage, PruneStage, Views, larger};
use crate::pairs::Block;
use crate::simulation_error::SimulationError;
use crate::team::{Guard, Work};

/// How the grains have moved.
#[derive(Clone, Copy)]
struct Moved {
    /// Square of the largest velocity of a grain, m2/s2.
    fastest: f64,
    /// True if a new neighbour list was built.
    renewed: bool,
}

/// The stage that the threads work on.
#[derive(Clone, Copy)]
enum StepStage {
    /// The grains sum their forces and move.
    Grains,
    /// The clumps sum the forces on their pieces and move.
    Clumps,
    /// The neighbour lists are pruned again, after the grains moved.
    Prune(Moved),
    /// The contacts are evaluated, after the grains moved.
    Contacts(Moved),
    /// The pieces that have bonds turn.
    Turning(Moved),
    /// The bonds are strained, judged and loaded.
    Bonds(Moved),
    /// The pieces that have bonds add up their loads.
    Bonded(Moved),
}

impl StepStage {
    /// Number of blocks that the threads share.
    fn blocks(self, views: &Views) -> usize {
        match self {
            StepStage::Bonds(_) => views.bonds.blocks()[0],
            StepStage::Turning(_) | StepStage::Bonded(_) => views.bonds.blocks()[1],
            _ => views.blocks.len(),
        }
    }
}

/// The data that the threads of a run share.
struct Team<'a> {
    work: Work,
    integrator: UnsafeCell<&'a mut Integrator>,
    views: UnsafeCell<Views>,
    stage: UnsafeCell<StepStage>,
    /// Number of steps still to be made.
    steps: UnsafeCell<u64>,
    failure: UnsafeCell<Option<SimulationError>>,
    threads: usize,
    contacts: kernel::ContactStageFunction,
    isa: granum_simd::Isa,
}
// SAFETY: the cells are written by one thread at a time, between the report of the last block of a stage and the opening of
// the next, when no other thread holds a block; the others read them only while they hold one.
unsafe impl Sync for Team<'_> {}

impl Team<'_> {
    /// The work of one thread.
    fn work(&self, thread: usize) {
        let _guard = Guard(&self.work);
        let mut turns = 0;
        loop {
            while let Some(blocks) = self.work.claim(thread) {
                // SAFETY: the stage does not change until the claimed blocks have been reported.
                let (views, stage) = unsafe { (&*self.views.get(), *self.stage.get()) };
                let (count, all) = (blocks.len(), stage.blocks(views));
                match stage {
                    StepStage::Grains if views.clumps.len() == 0 => {
                        dispatch(self.isa, GrainStage::<false> { views, blocks });
                    }
                    StepStage::Grains => dispatch(self.isa, GrainStage::<true> { views, blocks }),
                    StepStage::Clumps => dispatch(self.isa, ClumpStage { views, blocks }),
                    StepStage::Prune(_) => dispatch(self.isa, PruneStage { views, blocks }),
                    StepStage::Contacts(_) => (self.contacts)(views, blocks),
                    StepStage::Turning(_) => dispatch(self.isa, TurningStage { views, blocks }),
                    StepStage::Bonds(_) => bond_stage(self.isa, views, blocks, self.threads == 1),
                    StepStage::Bonded(_) => dispatch(self.isa, BondedStage { views, blocks }),
                }
                if self.work.report(count, all) {
                    // SAFETY: that was the last block, and no other can be claimed.
                    unsafe { self.turn(stage) };
                }
            }
            if !self.work.wait(thread, &mut turns) {
                return;
            }
        }
    }

    /// Opens the first stage.
    fn begin(&mut self) {
        self.integrator.get_mut().begin_step(self.views.get_mut());
        // SAFETY: no other thread has started yet.
        unsafe { self.open(StepStage::Grains) };
    }

    /// The serial work between two stages.
    ///
    /// # Safety
    /// Only when all blocks of the stage have been reported.
    unsafe fn turn(&self, stage: StepStage) {
        unsafe {
            let integrator = &mut *self.integrator.get();
            match stage {
                StepStage::Grains if integrator.state.has_clumps() => self.open(StepStage::Clumps),
                StepStage::Grains | StepStage::Clumps => {
                    let views = &mut *self.views.get();
                    let fastest = views.fastest_grain.read().iter().copied().fold(0.0, larger);
                    let renewed = integrator.list_is_stale(views, fastest);
                    if renewed {
                        self.renew();
                    }
                    let moved = Moved { fastest, renewed };
                    let stale = integrator.prune_again(&mut *self.views.get(), fastest, renewed);
                    self.open(if stale { StepStage::Prune(moved) } else { StepStage::Contacts(moved) });
                }
                StepStage::Prune(moved) => self.open(StepStage::Contacts(moved)),
                StepStage::Contacts(moved) if (*self.views.get()).bonds.blocks()[0] > 0 => {
                    self.open(StepStage::Turning(moved));
                }
                StepStage::Turning(moved) => self.open(StepStage::Bonds(moved)),
                // One thread alone has added up the loads with the bonds.
                StepStage::Bonds(moved) if self.threads > 1 => self.open(StepStage::Bonded(moved)),
                StepStage::Contacts(Moved { fastest, renewed })
                | StepStage::Bonds(Moved { fastest, renewed })
                | StepStage::Bonded(Moved { fastest, renewed }) => {
                    let steps = &mut *self.steps.get();
                    *steps -= 1;
                    integrator.exchange_liquid(&*self.views.get());
                    if let Err(error) = integrator.end_step(fastest, renewed) {
                        *self.failure.get() = Some(error);
                        self.work.end();
                    } else if *steps == 0 || integrator.event_has_come() {
                        self.work.end();
                    } else {
                        integrator.begin_step(&mut *self.views.get());
                        self.open(StepStage::Grains);
                    }
                }
            }
        }
    }

    /// # Safety
    /// As for [`Team::turn`].
    unsafe fn open(&self, stage: StepStage) {
        // SAFETY: no thread reads the stage or the views yet.
        let views = unsafe {
            *self.stage.get() = stage;
            &*self.views.get()
        };
        if let StepStage::Turning(_) | StepStage::Bonds(_) | StepStage::Bonded(_) = stage {
            let all = stage.blocks(views);
            return self.work.open(|thread| all * thread / self.threads..all * (thread + 1) / self.threads);
        }
        // SAFETY: as above.
        let blocks = unsafe { views.blocks.read() };
        self.work.open(|thread| share_batches(blocks, thread, self.threads));
    }

    /// Rebuilds the neighbour list and the views.
    ///
    /// # Safety
    /// As for [`Team::turn`].
    unsafe fn renew(&self) {
        unsafe {
            let integrator = &mut *self.integrator.get();
            let old = *self.views.get();
            integrator.rebuild();
            let mut views = integrator.views();
            views.gradient = old.gradient;
            views.dt = old.dt;
            views.sampling_weight = old.sampling_weight;
            views.retain = old.retain;
            *self.views.get() = views;
        }
    }
}

/// The share of a thread in the blocks, by number of batches: the first grains have more pairs than the last.
fn share_batches(blocks: &[Block], thread: usize, threads: usize) -> std::ops::Range<usize> {
    let all = blocks.last().map_or(0, |b| b.batches[2] as usize);
    // A block belongs to the thread whose share contains its middle.
    let before =
        |t: usize| blocks.partition_point(|b| (b.batches[0] + b.batches[2]) as usize * threads < 2 * all * t);
    let end = if thread + 1 == threads { blocks.len() } else { before(thread + 1) };
    before(thread)..end
}

/// The contact stage of an integrator.
fn contact_stage(integrator: &Integrator) -> kernel::ContactStageFunction {
    let stages = integrator.stages;
    if integrator.equal { stages.alike } else { stages.by_batch }
}

/// Advances by `steps` steps with the hardware settings of the integrator.
pub(crate) fn advance(integrator: &mut Integrator, steps: u64) -> Result<(), SimulationError> {
    if steps == 0 {
        return Ok(());
    }
    let threads = integrator.hardware.threads.max(1);
    let views = integrator.views();
    let mut team = Team {
        work: Work::new(threads),
        contacts: contact_stage(integrator),
        isa: integrator.hardware.isa,
        integrator: UnsafeCell::new(integrator),
        views: UnsafeCell::new(views),
        stage: UnsafeCell::new(StepStage::Grains),
        steps: UnsafeCell::new(steps),
        failure: UnsafeCell::new(None),
        threads,
    };
    team.begin();
    let shared = &team;
    std::thread::scope(|scope| {
        for thread in 1..threads {
            scope.spawn(move || shared.work(thread));
        }
        shared.work(0);
    });
    team.failure.into_inner().map_or(Ok(()), Err)
}

/// Computes the forces of the present geometry without moving anything and without advancing time.
pub(crate) fn forces(integrator: &mut Integrator) {
    let mut views = integrator.views();
    views.dt = 0.0;
    let blocks = 0..views.blocks.len();
    contact_stage(integrator)(&views, blocks.clone());
    // SAFETY: no other thread works on these views.
    if unsafe { integrator.exchange_liquid(&views) } {
        // With the bridges that have just formed.
        contact_stage(integrator)(&views, blocks);
    }
    integrator.bond_forces(&views);
    integrator.state.sums = ContactSums::total(&integrator.contact_sums);
    integrator.add_bonds();
    integrator.add_loads();
}

#[cfg(test)]
mod tests {
    use crate::config::{ContactModel, Grains, Material};
    use crate::random_insertion::random_insertion;
    use crate::servo::CellControl;
    use crate::simulation::{Hardware, Properties, Simulation};
    use granum_simd::Isa;

    /// Small enough for an interpreter that detects every data race (`cargo miri test`).
    #[test]
    fn threads_give_one_answer_through_several_lists() {
        let (count, steps) = if cfg!(miri) { (140, 12) } else { (600, 400) };
        let grains = Grains { count, ..Grains::default() };
        let (cell, spheres) = random_insertion(&grains, 0.35, 5).unwrap();
        let properties = Properties::new(Material::default(), ContactModel::default());
        let run = |threads: usize| {
            let mut s = Simulation::new(cell, &spheres, properties.clone()).unwrap();
            s.set_hardware(Hardware { threads, isa: Isa::detect() });
            s.set_control(CellControl::isotropic(20e3, 3e4));
            // So fast that grains collide and the list is rebuilt within the few steps.
            let fast: Vec<[f64; 3]> =
                (0..count).map(|k| [0, 1, 2].map(|a| 40.0 * ((7 * k + 13 * a) as f64).sin())).collect();
            s.set_velocities(&fast, &[]);
            s.advance(steps).unwrap();
            assert!(s.rebuilds() > 1 && s.state().pairs.blocks.len() > 1);
            s
        };
        let (one, three) = (run(1), run(3));
        assert!(one.state() == three.state());
    }
}
