// How often the picture may be drawn: the station may live on the same machine, and comes first. Numbers only.

/** Keeps drawing below a share of the time, whatever one picture costs on this machine. */
export class Pace {
    private freeAt = -Infinity;

    /** `share` of the time that drawing may take, in (0, 1]; `longest` wait between two pictures [ms]. */
    constructor(
        private readonly share: number,
        private readonly longest: number,
    ) {}

    /** How long to wait before the next picture [ms]; 0 when it may be drawn at once. */
    wait(now: number): number {
        return Math.max(0, this.freeAt - now);
    }

    /** A picture was drawn from `begin` to `end` [ms]. */
    drawn(begin: number, end: number): void {
        const pause = (end - begin) * (1 / this.share - 1);
        this.freeAt = end + Math.min(pause, this.longest);
    }
}
