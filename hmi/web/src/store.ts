// The one store: everything the screen knows, and who wants to hear of which change.
import type { Cell, LiveMessage, Mark, Mesh, Part, Voxels } from "./protocol";

export type ViewName = "part" | "cell";
export type LinkState = "connecting" | "open" | "lost";

export interface ScreenState {
    readonly link: LinkState;
    /** The last live message, however old. */
    readonly live: LiveMessage | null;
    /** When its frame was new, on the browser's clock [ms]; null before the first frame. */
    readonly frameAt: number | null;
    /** The browser's clock [ms], advanced a few times a second. */
    readonly now: number;
    /** When the station's newest trouble was new, on the browser's clock [ms]. */
    readonly troubleAt: number;
    readonly part: Part | null;
    readonly mesh: Mesh | null;
    readonly cell: Cell | null;
    readonly marks: readonly Mark[];
    /** Marks that came in while this page was watching, with when. */
    readonly arrivals: ReadonlyMap<number, number>;
    readonly voxels: Voxels | null;
    readonly selectedMark: number | null;
    readonly view: ViewName;
    readonly sound: "off" | "on";
    /** What the station said that this page could not use; empty when all is well. */
    readonly misunderstood: string;
}

export type StateKey = keyof ScreenState;
export type Changed = ReadonlySet<StateKey>;
export type Listener = (state: ScreenState, changed: Changed) => void;

export const emptyState: ScreenState = {
    link: "connecting",
    live: null,
    frameAt: null,
    now: 0,
    troubleAt: -Infinity,
    part: null,
    mesh: null,
    cell: null,
    marks: [],
    arrivals: new Map(),
    voxels: null,
    selectedMark: null,
    view: "part",
    sound: "off",
    misunderstood: "",
};

export class Store {
    private current: ScreenState;
    private readonly listeners = new Set<Listener>();

    constructor(initial: ScreenState = emptyState) {
        this.current = initial;
    }

    get state(): ScreenState {
        return this.current;
    }

    /** Listeners hear of it once, at once, and only when a value is really another one. */
    update(patch: Partial<ScreenState>): void {
        const changed = new Set<StateKey>();
        for (const key of Object.keys(patch) as StateKey[])
            if (!Object.is(this.current[key], patch[key])) changed.add(key);
        if (changed.size === 0) return;
        this.current = { ...this.current, ...patch };
        for (const listener of [...this.listeners]) listener(this.current, changed);
    }

    /** Calls back now with everything, then at each change of one of `keys`. Returns how to stop. */
    watch(keys: readonly StateKey[], listener: Listener): () => void {
        const filtered: Listener = (state, changed) => {
            if (keys.some((key) => changed.has(key))) listener(state, changed);
        };
        this.listeners.add(filtered);
        listener(this.current, new Set(keys));
        return () => this.listeners.delete(filtered);
    }

    /** A live message from the station at browser time `now` [ms]. */
    takeLive(live: LiveMessage, now: number): void {
        const before = this.current.live?.frame ?? null;
        const fresh = live.frame !== null && live.frame.timestampUs !== before?.timestampUs;
        // A message without a frame says how the rest is; the last frame stays until it counts as stale.
        this.update({
            live: live.frame === null ? { ...live, frame: before } : live,
            now,
            ...(fresh ? { frameAt: now } : {}),
            ...(live.trouble !== (this.current.live?.trouble ?? "") ? { troubleAt: now } : {}),
        });
    }

    /** The marks as the record has them now; those that are new since the last time have just arrived. */
    takeMarks(marks: readonly Mark[], now: number, first: boolean): void {
        const known = new Set(this.current.marks.map((mark) => mark.id));
        const arrivals = new Map<number, number>();
        for (const mark of marks) {
            const arrived = this.current.arrivals.get(mark.id) ?? (known.has(mark.id) || first ? undefined : now);
            if (arrived !== undefined) arrivals.set(mark.id, arrived);
        }
        const selected = marks.some((mark) => mark.id === this.current.selectedMark);
        this.update({ marks, arrivals, selectedMark: selected ? this.current.selectedMark : null });
    }
}
