//! Flow through portals: what is seen through a chain of them, clipped ever smaller, until nothing undecided is left.

use super::flood::{FloodInput, FloodScratch, Shaft, flood};
use super::lines::{Found, Line, Random, follow, is_new};
use super::openings::Openings;
use super::polygon::{Polygon, separators};
use super::rows::{BitRows, clear, has, ones, set};

/// Portals of a chain at the most. What lies behind a longer one is kept.
const MOST_DEPTH: usize = 96;

/// What is known when a round begins; nobody changes it meanwhile.
#[derive(Clone, Debug)]
pub(super) struct Known {
    /// Of each opening the cells that may be seen through it.
    pub(super) might: BitRows,
    /// Of each cell those that it may see.
    pub(super) possible: BitRows,
    /// Of each cell those that a line proves visible.
    pub(super) visible: BitRows,
}

/// How much work was done.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Work {
    pub(super) lines: u64,
    pub(super) nodes: u64,
    pub(super) clips: u64,
    pub(super) floods: u64,
    pub(super) flood_tests: u64,
}

/// Work of one cell.
#[derive(Debug)]
pub(super) struct Flow<'a> {
    pub(super) openings: &'a Openings,
    pub(super) known: &'a Known,
    pub(super) cell: u32,
    /// Cells that this one is known to see.
    pub(super) visible: Vec<u64>,
    /// Cells whose pair with this one is undecided and that no chain reached yet.
    pub(super) wanted: Vec<u64>,
    /// Cells that a chain reached though no line was found.
    pub(super) kept: Vec<u64>,
    pub(super) found: Found,
    pub(super) random: Random,
    pub(super) tries: u32,
    pub(super) work: Work,
    scratch: FloodScratch,
    /// Wanted cells that are still ahead, for each depth, and what a flood reached.
    ahead: Vec<u64>,
    reached: Vec<u64>,
    line: Vec<u32>,
    chain: Vec<u32>,
}

impl<'a> Flow<'a> {
    pub(super) fn new(openings: &'a Openings, known: &'a Known) -> Self {
        let (cells, width) = (known.visible.rows(), known.visible.width());
        Self {
            openings,
            known,
            cell: 0,
            visible: vec![0; width],
            wanted: vec![0; width],
            kept: vec![0; width],
            found: Found::default(),
            random: Random::new(0, [0; 2]),
            tries: 16,
            work: Work::default(),
            scratch: FloodScratch::new(cells),
            ahead: vec![0; width * (MOST_DEPTH + 2)],
            reached: vec![0; width],
            line: Vec::new(),
            chain: Vec::new(),
        }
    }

    /// Turns to a cell and the undecided cells that are its task.
    pub(super) fn begin(&mut self, cell: u32, wanted: &[u64], random: Random) {
        self.cell = cell;
        self.visible.copy_from_slice(self.known.visible.row(cell));
        self.wanted.copy_from_slice(wanted);
        self.kept.fill(0);
        self.found = Found::default();
        self.random = random;
    }

    /// Tries a line of sight through an opening of this cell; whether it proved anything that was wanted.
    pub(super) fn try_line(&mut self, line: &Line) -> bool {
        self.work.lines += 1;
        let mut cells = std::mem::take(&mut self.line);
        follow(self.openings, line, &mut cells);
        let mut news = false;
        if !cells.is_empty() {
            for &cell in &cells {
                if !has(&self.visible, cell) {
                    set(&mut self.visible, cell);
                    clear(&mut self.wanted, cell);
                    clear(&mut self.kept, cell);
                    news = true;
                }
            }
            if news || is_new(&self.known.visible, &cells) {
                self.found.push(*line, &cells);
            }
        }
        self.line = cells;
        news
    }

    /// Aims lines at undecided cells next to what is seen, as far as that leads.
    pub(super) fn aim(&mut self, tries: u32) {
        let openings = self.openings;
        let leaving = openings.leaving(self.cell);
        let mut front: Vec<u32> = ones(&self.visible).collect();
        let mut doors = Vec::new();
        while let Some(cell) = front.pop() {
            for target in openings.leaving(cell) {
                let to = openings.get(target).to;
                if !has(&self.wanted, to)
                    || !has(self.known.might.row(openings.get(target).reverse), self.cell)
                {
                    continue;
                }
                doors.clear();
                doors.extend(leaving.clone().filter(|&door| has(self.known.might.row(door), to)));
                if doors.is_empty() {
                    continue;
                }
                let before = self.found.lines.len();
                for k in 0..tries {
                    let door = doors[(k as usize + before) % doors.len()];
                    let point = openings.get(door).polygon.point(self.random.three());
                    let end = openings.get(target).polygon.point(self.random.three());
                    let Some(direction) = (end - point).try_normalize() else { continue };
                    self.try_line(&Line { opening: door, point, direction });
                    if !has(&self.wanted, to) {
                        break;
                    }
                }
                if has(&self.visible, to) {
                    front.push(to);
                }
            }
        }
    }

    /// Follows all chains of portals that could lead to something wanted through an opening; the cells that it may see
    /// afterwards are what was wanted before and is reached.
    pub(super) fn through(&mut self, door: u32) {
        let width = self.wanted.len();
        let opening = self.openings.get(door);
        let might = self.known.might.row(door);
        for (k, word) in self.ahead[..width].iter_mut().enumerate() {
            *word = self.wanted[k] & might[k];
        }
        self.reach(door, opening.to, &opening.polygon, &opening.polygon);
        if self.ahead[..width].iter().any(|&w| w != 0) {
            self.chain.clear();
            self.chain.push(self.cell);
            self.chain.push(opening.to);
            let source = opening.polygon;
            self.descend(1, [door, door], &source, &source);
        }
    }

    /// A chain reached a cell: if it was wanted, looks for a line, and is done with it in any case.
    fn reach(&mut self, door: u32, to: u32, source: &Polygon, target: &Polygon) {
        if !has(&self.wanted, to) {
            return;
        }
        for k in 0..self.tries {
            let (point, end) = match k {
                0 => (source.centre(), target.centre()),
                _ => (source.point(self.random.three()), target.point(self.random.three())),
            };
            let towards = match end == point {
                true => self.openings.get(door).normal,
                false => end - point,
            };
            let Some(direction) = towards.try_normalize() else { continue };
            self.try_line(&Line { opening: door, point, direction });
            if !has(&self.wanted, to) {
                return;
            }
        }
        clear(&mut self.wanted, to);
        set(&mut self.kept, to);
    }

    /// The wanted cells that lie ahead at `depth - 1` are sought beyond the last of a chain's openings, `door` being the
    /// first: `source` is what is left of that, `pass` of the last.
    fn descend(&mut self, depth: usize, [door, last]: [u32; 2], source: &Polygon, pass: &Polygon) {
        let width = self.wanted.len();
        let openings = self.openings;
        let (tolerance, slack) = (openings.tolerance, openings.tolerance * 1e-3);
        if depth >= MOST_DEPTH {
            for k in 0..width {
                let all = self.ahead[(depth - 1) * width + k] & self.wanted[k];
                self.wanted[k] &= !all;
                self.kept[k] |= all;
            }
            return;
        }
        self.work.nodes += 1;
        let cell = openings.get(last).to;
        let first = openings.get(door);
        let mut planes = match depth {
            1 => super::polygon::HalfSpaces::NONE,
            _ => separators(source, pass, false, slack),
        };
        planes.push(first.normal, first.d);
        if depth > 1 {
            let passed = openings.get(last);
            planes.push(passed.normal, passed.d);
        }
        let shaft = Shaft::new(&planes);
        let (known, reverse) = (self.known, openings.get(last).reverse);
        if depth > 1 {
            self.work.floods += 1;
            let mut reached = std::mem::take(&mut self.reached);
            let ahead = &mut self.ahead[(depth - 1) * width..depth * width];
            let input = FloodInput {
                openings,
                might: &known.might,
                behind: [self.cell, openings.get(last).from],
                shaft: &shaft,
            };
            let any = flood(&input, cell, ahead, &mut reached, &mut self.scratch, &mut self.work.flood_tests);
            ahead.copy_from_slice(&reached);
            self.reached = reached;
            if !any {
                return;
            }
        }
        for next in openings.leaving(cell) {
            if next == reverse {
                continue;
            }
            let opening = openings.get(next);
            let back = known.might.row(opening.reverse);
            if !has(back, self.cell) || !shaft.meets(openings.bounds(next), openings.tolerance32) {
                continue;
            }
            let might = known.might.row(next);
            let mut any = 0;
            for k in 0..width {
                let word = self.ahead[(depth - 1) * width + k] & might[k] & self.wanted[k];
                self.ahead[depth * width + k] = word;
                any |= word;
            }
            if any == 0 || !self.chain.iter().all(|&behind| has(back, behind)) {
                continue;
            }
            self.work.clips += 1;
            let mut target = opening.polygon;
            if !target.clip_all(&planes, tolerance) {
                continue;
            }
            let mut source = *source;
            if !source.clip(-opening.normal, -opening.d, tolerance) {
                continue;
            }
            if depth > 1 {
                let backward = separators(&target, pass, true, slack);
                if !source.clip_all(&backward, tolerance) {
                    continue;
                }
            }
            self.reach(door, opening.to, &source, &target);
            let mut more = 0;
            for k in 0..width {
                self.ahead[depth * width + k] &= self.wanted[k];
                more |= self.ahead[depth * width + k];
            }
            if more != 0 && !self.chain.contains(&opening.to) {
                self.chain.push(opening.to);
                self.descend(depth + 1, [door, next], &source, &target);
                self.chain.pop();
            }
        }
    }
}
