// What is begun before the page is there. The build makes a file of its own of it (`vite.config.ts`), so small that it comes first; what it opens,
// `protocol/stream` finds. Must never take part in what the page does.

import { chosenLanguage } from '../language/choice';
import { tabId } from '../model/tab';
import { openEarly, wasAsked } from '../protocol/early';
import { streamUrl } from '../protocol/streamUrl';

/** The stream takes room on a thin link too, so it is opened when all but the last file of the page is there: it answers as that one comes. */
const files = document.querySelectorAll('link[rel="modulepreload"], link[rel="stylesheet"], script[src]').length;
let come = 0;
const observer = new PerformanceObserver((list) => {
  come += list.getEntriesByType('resource').length;
  if (come < files - 1) return;
  observer.disconnect();
  if (!wasAsked()) openEarly(streamUrl(document.baseURI, tabId()));
});
observer.observe({ type: 'resource', buffered: true });
// Whoever misses it asks again.
if (chosenLanguage() === 'de') import('../language/de').catch(() => {});
