// Which flight has ended while the page was open. Pure but for what it keeps.

export class LastFlight {
  #known: string | null | undefined = undefined;

  /** Takes what the node calls its last flight; gives it if it has ended since it was asked first. A node that began anew knows none, and that is no news. */
  take(last: string | null): string | null {
    const isFirst = this.#known === undefined;
    if (last === this.#known) return null;
    if (last === null && !isFirst) return null;
    this.#known = last;
    return isFirst ? null : last;
  }
}
