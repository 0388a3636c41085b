// What is begun before the page is there. The build makes a file of its own of it (`vite.config.ts`), so small that it comes first; what it opens,
// `protocol/stream` finds. Must never take part in what the page does.

import { chosenLanguage } from '../language/choice';
import { tabId } from '../model/tab';
import { openEarly, wasAsked } from '../protocol/early';
import { streamUrl } from '../protocol/streamUrl';

// The vehicles' words are wanted as much as the page's own files, and over a slow link the way there and back takes longest.
if (!wasAsked()) openEarly(streamUrl(document.baseURI, tabId()));
// Whoever misses it asks again.
if (chosenLanguage() === 'de') import('../language/de').catch(() => {});
