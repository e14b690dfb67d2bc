// The line read from three metres: can I mark now, and if not, why; with the part's name at its side.
import { headline } from "../situation";
import type { Store } from "../store";
import { element, Glyph, say } from "./elements";

export function mountHeadline(root: HTMLElement, store: Store): () => void {
    const sign = new Glyph();
    const title = element("h1");
    const detail = element("p", "detail");
    const type = element("span", "part-type");
    const serial = element("span", "part-serial");
    root.append(
        sign.element,
        element("div", "words", { role: "status" }, title, detail),
        element("div", "part-name", {}, element("span", "caption", {}, "Part"), type, serial),
    );
    return store.watch(["link", "live", "frameAt", "now", "part"], (state) => {
        const line = headline(state);
        root.dataset["severity"] = line.severity;
        sign.show(line.severity);
        say(title, line.title);
        say(detail, line.detail);
        say(type, state.part?.type ?? "none");
        say(serial, state.part === null || state.part.serial === "" ? "" : `No. ${state.part.serial}`);
    });
}
