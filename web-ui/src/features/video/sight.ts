// Whether something is in sight: on the screen, in a tab that is looked at. What is not costs neither the link nor the processor.

/** What leaves the screen for a moment, while one scrolls past, stays. */
const LEAVE_MS = 400;

/** Calls `changed` whenever it comes into sight or is gone, until the returned function is called. At first it is not in sight. */
export function watchSight(element: Element, changed: (inSight: boolean) => void): () => void {
  let onScreen = false;
  let said = false;
  let timer: ReturnType<typeof setTimeout> | undefined;
  const say = (inSight: boolean): void => {
    said = inSight;
    changed(inSight);
  };
  const look = (): void => {
    clearTimeout(timer);
    const inSight = onScreen && !document.hidden;
    if (inSight && !said) say(true);
    else if (!inSight && said) timer = setTimeout(() => say(false), LEAVE_MS);
  };
  const observer = new IntersectionObserver((entries) => {
    onScreen = entries.at(-1)?.isIntersecting ?? false;
    look();
  });
  observer.observe(element);
  document.addEventListener('visibilitychange', look);
  return () => {
    clearTimeout(timer);
    observer.disconnect();
    document.removeEventListener('visibilitychange', look);
  };
}
