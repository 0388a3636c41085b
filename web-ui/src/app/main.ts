// Where the page begins.

import { mount } from 'svelte';
import { language } from '../language/language.svelte';
import App from './App.svelte';
import './theme.css';

const target = document.getElementById('app');
void language.start().then(() => target && mount(App, { target }));
