// Where the page begins.

import { mount } from 'svelte';
import { language } from '../language/language.svelte';
import { units } from '../language/units.svelte';
import App from './App.svelte';
import './theme.css';

units.start();
const target = document.getElementById('app');
void language.start().then(() => target && mount(App, { target }));
