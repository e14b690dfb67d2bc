// The alarm line: what is wrong besides the headline, and what to do about it; nothing when all is well.
import { alarms } from "../situation";
import type { Store } from "../store";
import { element, glyph } from "./elements";

export function mountAlarms(root: HTMLElement, store: Store): () => void {
    let shown = "";
    return store.watch(["link", "live", "now", "misunderstood"], (state) => {
        const current = alarms(state);
        const key = JSON.stringify(current);
        if (key === shown) return;
        shown = key;
        root.replaceChildren(
            ...current.map((alarm) =>
                element(
                    "div",
                    `alarm ${alarm.severity}`,
                    {},
                    glyph(alarm.severity),
                    element("strong", "", {}, alarm.text),
                    element("span", "", {}, alarm.response),
                ),
            ),
        );
    });
}
