// The defects of this part as a list, newest first; tapping one shows it on the part.
import type { Mark } from "../protocol";
import { standingMarks } from "../situation";
import type { Store } from "../store";
import { element, say } from "./elements";

const newForMs = 6000;

function clockTime(rfc3339: string): string {
    const time = new Date(rfc3339);
    return Number.isNaN(time.getTime()) ? "" : time.toLocaleTimeString("en-GB");
}

function millimetres(metres: number): string {
    return String(Math.round(metres * 1000)).replace("-", "\u2212");
}

function row(mark: Mark, choose: () => void): HTMLButtonElement {
    const sure = `${Math.round(mark.confidence * 100)} %`;
    const facts = [clockTime(mark.time), `${mark.arm} arm${mark.touch ? ", touched" : ""}`, sure];
    const [x, y, z] = mark.position;
    const button = element(
        "button",
        `mark ${mark.state}`,
        { type: "button", "data-mark": String(mark.id) },
        element("span", "number", {}, String(mark.id)),
        element(
            "span",
            "what",
            {},
            element(
                "span",
                "heading",
                {},
                element("span", "zone", {}, mark.zone === "" ? "outside all zones" : mark.zone),
                element("span", "state", {}, mark.state),
            ),
            element("span", "facts", {}, facts.filter((fact) => fact !== "").join(" \u00b7 ")),
            element("span", "facts place", {}, `x ${millimetres(x)}  y ${millimetres(y)}  z ${millimetres(z)} mm`),
        ),
    );
    button.addEventListener("click", choose);
    return button;
}

export function mountMarks(root: HTMLElement, store: Store): () => void {
    const count = element("span", "count", { "data-testid": "count" });
    const noun = element("span", "noun");
    const list = element("ol", "list");
    const empty = element("p", "empty", {}, "No defects marked on this part.");
    root.append(element("h2", "", {}, count, noun), empty, list);

    const rows = new Map<number, { key: string; item: HTMLLIElement; button: HTMLButtonElement }>();
    const rebuild = (marks: readonly Mark[]) => {
        const ids = new Set(marks.map((mark) => mark.id));
        for (const [id, { item }] of rows) {
            if (ids.has(id)) continue;
            item.remove();
            rows.delete(id);
        }
        for (const mark of [...marks].reverse()) {
            const key = JSON.stringify(mark);
            const old = rows.get(mark.id);
            if (old?.key === key) continue;
            const choose = () => store.update({ selectedMark: store.state.selectedMark === mark.id ? null : mark.id });
            const button = row(mark, choose);
            const item = old?.item ?? element("li");
            item.replaceChildren(button);
            rows.set(mark.id, { key, item, button });
        }
        const order = [...marks].reverse().flatMap((mark) => rows.get(mark.id)?.item ?? []);
        if (order.some((item, i) => list.children[i] !== item)) {
            list.replaceChildren(...order);
            list.scrollTop = 0;
        }
    };
    return store.watch(["marks", "arrivals", "selectedMark", "now"], (state, changed) => {
        if (changed.has("marks")) rebuild(state.marks);
        const standing = standingMarks(state);
        say(count, String(standing));
        say(noun, standing === 1 ? "defect" : "defects");
        empty.hidden = state.marks.length > 0;
        for (const [id, { button }] of rows) {
            button.setAttribute("aria-pressed", String(id === state.selectedMark));
            const arrived = state.arrivals.get(id);
            button.classList.toggle("new", arrived !== undefined && state.now - arrived < newForMs);
        }
        if (changed.has("selectedMark") && state.selectedMark !== null)
            rows.get(state.selectedMark)?.item.scrollIntoView({ block: "nearest" });
    });
}
