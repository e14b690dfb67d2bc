// The one connection to the station: the live stream, and what it tells us to fetch. Reconnects by itself.
import { decodeMesh, decodeVoxels, parseCell, parseLive, parseMarks, parsePart, parseState, ProtocolError } from "./protocol";
import { linkIsLost } from "./situation";
import type { Store } from "./store";

const retryMs = 500;
const silenceMs = 3000;
const refreshMarksMs = 5000;
const tickMs = 200;

export class Connection {
    private socket: WebSocket | null = null;
    private closedAt: number | null;
    private heardAt = 0;
    private marksTotal = -1;
    private marksAt = -Infinity;
    private marksBusy = false;
    private marksAgain = false;
    private marksKnown = false;
    private partBusy = false;
    private partAt = -Infinity;
    private retryAt = 0;
    private readonly nonsense = new Map<string, string>();
    private readonly timer: number;

    constructor(
        private readonly store: Store,
        private readonly clock: () => number = () => performance.now(),
    ) {
        this.closedAt = this.clock();
        this.timer = window.setInterval(() => this.tick(), tickMs);
        this.open();
        void this.fetchState();
    }

    dispose(): void {
        window.clearInterval(this.timer);
        if (this.socket !== null) this.forget(this.socket);
        this.socket = null;
    }

    private open(): void {
        const socket = new WebSocket(`ws://${window.location.host}/api/live`);
        socket.binaryType = "arraybuffer";
        socket.onopen = () => {
            this.heardAt = this.clock();
            void this.fetchPart();
            void this.fetchMarks();
        };
        socket.onmessage = (event: MessageEvent<string | ArrayBuffer>) => this.hear(event.data);
        socket.onclose = () => this.lose();
        this.socket = socket;
    }

    private forget(socket: WebSocket): void {
        socket.onopen = socket.onmessage = socket.onclose = null;
        socket.close();
    }

    private lose(): void {
        if (this.socket !== null) this.forget(this.socket);
        this.socket = null;
        this.closedAt ??= this.clock();
        this.retryAt = this.clock() + retryMs;
    }

    private hear(data: string | ArrayBuffer): void {
        const now = this.clock();
        this.heardAt = now;
        // Only a station that speaks is there: one that hangs may still take connections.
        this.closedAt = null;
        this.store.update({ link: "open" });
        if (typeof data !== "string") {
            this.understand("voxels", () => this.store.update({ voxels: decodeVoxels(data) }));
            return;
        }
        this.understand("live", () => {
            const live = parseLive(JSON.parse(data));
            this.store.takeLive(live, now);
            if (live.marksTotal !== this.marksTotal) {
                this.marksTotal = live.marksTotal;
                void this.fetchMarks();
            }
        });
    }

    private tick(): void {
        const now = this.clock();
        // A station that is there says something several times a second, if only that it has no frame.
        if (this.socket?.readyState === WebSocket.OPEN && now - this.heardAt > silenceMs) this.lose();
        if (this.socket === null && now >= this.retryAt) this.open();
        const lost = linkIsLost(this.closedAt, now);
        this.store.update(lost ? { now, link: "lost" } : { now });
        if (this.closedAt !== null) return;
        if (now - this.marksAt > refreshMarksMs) void this.fetchMarks();
        if (now - this.partAt > refreshMarksMs) void this.fetchPart();
    }

    /** Runs `use`; what it could not understand stands as an alarm until the same source makes sense again. */
    private understand(source: string, use: () => void): void {
        try {
            use();
            this.nonsense.delete(source);
        } catch (error) {
            const known = error instanceof ProtocolError;
            this.nonsense.set(source, known ? error.message : "The station sent something unreadable.");
        }
        this.store.update({ misunderstood: [...this.nonsense.values()][0] ?? "" });
    }

    /** The answer's body; undefined when the station refuses or is not to be reached now. */
    private async get<T>(path: string, read: (response: Response) => Promise<T>): Promise<T | undefined> {
        try {
            const response = await fetch(path);
            return response.ok ? await read(response) : undefined;
        } catch {
            return undefined;
        }
    }

    private getJson(path: string): Promise<unknown> {
        return this.get<unknown>(path, (response) => response.json());
    }

    private async fetchState(): Promise<void> {
        const body = await this.getJson("/api/state");
        if (body === undefined) return;
        this.understand("state", () => {
            const state = parseState(body);
            if (state === null || this.store.state.live !== null) return;
            const now = this.clock();
            this.store.takeLive(state.live, now);
            if (this.store.state.frameAt !== null) this.store.update({ frameAt: now - state.ageMs });
        });
    }

    private async fetchMarks(): Promise<void> {
        if (this.marksBusy) {
            this.marksAgain = true;
            return;
        }
        this.marksBusy = true;
        do {
            this.marksAgain = false;
            this.marksAt = this.clock();
            const body = await this.getJson("/api/marks");
            if (body === undefined) continue;
            this.understand("marks", () => {
                this.store.takeMarks(parseMarks(body), this.clock(), !this.marksKnown);
                this.marksKnown = true;
            });
        } while (this.marksAgain);
        this.marksBusy = false;
    }

    private async fetchPart(): Promise<void> {
        if (this.partBusy) return;
        this.partBusy = true;
        this.partAt = this.clock();
        if (this.store.state.cell === null) {
            const cell = await this.getJson("/api/cell");
            if (cell !== undefined && cell !== null)
                this.understand("cell", () => this.store.update({ cell: parseCell(cell) }));
        }
        const body = await this.getJson("/api/part");
        if (body !== undefined) await this.takePart(body);
        this.partBusy = false;
    }

    private async takePart(body: unknown): Promise<void> {
        const before = this.store.state.part;
        let tag = "";
        this.understand("part", () => {
            const part = body === null ? null : parsePart(body);
            tag = part?.meshTag ?? "";
            if (part === null) this.store.update({ part, mesh: null });
            else if (JSON.stringify(part) !== JSON.stringify(before)) this.store.update({ part });
        });
        if (tag === "" || (tag === before?.meshTag && this.store.state.mesh !== null)) return;
        const bytes = await this.get("/api/part/mesh", (response) => response.arrayBuffer());
        if (bytes !== undefined) this.understand("mesh", () => this.store.update({ mesh: decodeMesh(bytes) }));
    }
}
