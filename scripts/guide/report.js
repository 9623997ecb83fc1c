// Answers what a reader of a report would see wrong: text over text, bars that lie, what is cut.
() => {
    const words = e => e.textContent.trim().replace(/\s+/g, " ").slice(0, 60);
    const found = [];
    const over = document.documentElement.scrollWidth - document.documentElement.clientWidth;
    if (over > 0) found.push(`the page is ${over} px wider than the screen`);
    for (const e of document.querySelectorAll("pre.command, .key div, h1, h2, h3, p")) {
        const cut = e.scrollWidth - e.clientWidth;
        if (e.clientWidth > 0 && cut > 0) found.push(`cut by ${cut} px: "${words(e)}"`);
    }
    const boxes = (root, selector) => [...root.querySelectorAll(selector)]
        .map(e => [e, e.getBoundingClientRect()])
        .filter(([e, box]) => box.width > 0 && box.height > 0);
    for (const svg of document.querySelectorAll("svg")) {
        const texts = boxes(svg, "text").filter(([e]) => words(e) !== "");
        texts.forEach(([a, p], k) => texts.slice(k + 1).forEach(([b, q]) => {
            const wide = Math.min(p.right, q.right) - Math.max(p.left, q.left);
            // the box of a text is a line high, its letters are lower
            const high = Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top);
            if (wide > 1 && high > 0.25 * Math.min(p.height, q.height)) {
                found.push(`"${words(a)}" lies over "${words(b)}"`);
            }
        }));
        // a panorama is moved sideways within its figure
        const frame = svg.closest("figure") ?? document.body;
        const moves = /auto|scroll/.test(getComputedStyle(frame).overflowX);
        const whole = (moves ? svg : frame).getBoundingClientRect();
        for (const [e, box] of texts) {
            const beyond = Math.max(box.right - whole.right, whole.left - box.left);
            if (beyond > (moves ? 8 : 1)) {
                found.push(`"${words(e)}" stands ${beyond.toFixed(0)} px beyond its picture`);
            }
        }
        found.push(...lying(boxes(svg, "rect.bar"), texts));
    }
    return [...new Set(found)];

    // bars whose lengths do not go with the numbers that stand beside them, or in their titles
    function lying(bars, texts) {
        const told = bars.map(([bar, box]) => {
            // the number of a row, also where its bar reaches into it
            const beside = texts.find(([e, at]) =>
                at.left > box.left && at.top < box.bottom && at.bottom > box.top
                    && /^-?[\d.,]+ /.test(words(e)));
            if (beside) return [parseFloat(words(beside[0]).replace(/,/g, "")), box.width];
            const count = /: ([\d,]+) /.exec(bar.querySelector("title")?.textContent ?? "");
            return count && [parseFloat(count[1].replace(/,/g, "")), box.height];
        }).filter(pair => pair);
        const [most, longest] = told.reduce((a, b) => (b[1] > a[1] ? b : a), [1, 1]);
        // what is told is rounded
        const unit = told.every(([value]) => Number.isInteger(value)) ? 1 : 0.1;
        const off = (value, length) => Math.abs(length / longest - value / most);
        const that = `that of ${most} ${longest.toFixed(0)} px`;
        return told
            .filter(([value, length]) => off(value, length) > 0.01 + unit / most)
            .map(([value, length]) => `a bar of ${value} is ${length.toFixed(0)} px long, ${that}`);
    }
}
